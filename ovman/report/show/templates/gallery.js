"use strict";
(() => {
  const form = document.getElementById("filters"), count = document.getElementById("count");
  const fields = [...form.querySelectorAll("select")], agents = form.dataset.agents.split("|");
  const cards = [...document.querySelectorAll("article")].map((card) => {
    const pins = [...card.querySelectorAll(".pin")];
    const queries = [...card.querySelectorAll("ol > li")].map((row) => ({
      row, pins: pins.filter((pin) => pin.dataset.query === String(row.value)),
    }));
    return { card, queries };
  });
  const total = cards.reduce((sum, { queries }) => sum + queries.length, 0);

  const agrees = (card, row, wanted) =>
    (!wanted.rooms || card.dataset.rooms === wanted.rooms) &&
    (!wanted.relation || row.dataset.relation === wanted.relation) &&
    (!wanted.noun || row.dataset.noun === wanted.noun) &&
    (!wanted.failed || row.dataset.found[agents.indexOf(wanted.failed)] === "0") &&
    (!wanted.found || row.dataset.found[agents.indexOf(wanted.found)] === "1");

  function filter() {
    const wanted = Object.fromEntries(fields.map((field) => [field.name, field.value]));
    let homes = 0, asked = 0;
    for (const { card, queries } of cards) {
      let here = 0;
      for (const { row, pins } of queries) {
        const fits = agrees(card, row, wanted);
        row.hidden = !fits;
        for (const pin of pins) pin.classList.toggle("off", !fits);
        here += fits;
      }
      card.hidden = here === 0;
      homes += here > 0;
      asked += here;
    }
    count.textContent = `${homes} of ${cards.length} world pairs, ${asked} of ${total} queries`;
  }

  // The fragment holds the filters, so that a view can be linked. A fragment without "=" names a card.
  function read() {
    const fragment = location.hash.slice(1);
    if (fragment && !fragment.includes("=")) return;
    const given = new URLSearchParams(fragment);
    for (const field of fields) {
      field.value = given.get(field.name) ?? "";
      if (field.selectedIndex < 0) field.value = "";
    }
  }

  function write() {
    const chosen = fields.filter((field) => field.value).map((field) => [field.name, field.value]);
    history.replaceState(null, "", `#${new URLSearchParams(chosen)}`);
  }

  form.addEventListener("change", () => { write(); filter(); });
  form.addEventListener("reset", () => setTimeout(() => { write(); filter(); }));
  form.addEventListener("submit", (event) => event.preventDefault());
  addEventListener("hashchange", () => { read(); filter(); });
  form.hidden = false;
  read();
  filter();
})();
