"use strict";
// What the thresholds make of the records. All numbers are counted here from the tables that `ovman explore` wrote.
const data = JSON.parse(document.getElementById("data").textContent);
const names = Object.keys(data.sliders);
const alphabet = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
const parts = [["delta_min_m", "validity_radius_m"], ["tau_m", "delta_min_m", "min_mask_px"], ["drift_tolerance_m"], ["radius_m"]];
const $ = (id) => document.getElementById(id);

function reasonOf(trial, at) {
  for (let part = 0; part < 4; part++) {
    const table = data.tables[trial[1 + part]];
    let place = 0;
    if (table.length > 1) for (const name of parts[part]) place = place * data.sliders[name].length + at[name];
    const code = alphabet.indexOf(table[place]);
    if (code > 0) return code;
  }
  return 0;
}

function read(at) {
  const relations = data.relations.length, rejected = data.reasons.map(() => new Array(relations).fill(0));
  const left = data.episodes.map(() => false);
  for (const trial of data.trials) {
    const code = reasonOf(trial, at);
    rejected[code][trial[0]]++;
    if (code === 0 && trial[5] >= 0) left[trial[5]] = true;
  }
  const arms = data.arms.map((arm) => {
    const sums = new Array(relations + 1).fill(0), counts = new Array(relations + 1).fill(0);
    for (const run of arm.runs) for (let k = 0; k < left.length; k++) {
      if (!left[k]) continue;
      let success;
      if (typeof run === "string") {
        if (run[k] === " ") continue;
        success = run[k] !== "-" && alphabet.indexOf(run[k]) <= at.radius_m ? 1 : 0;
      } else {
        success = run[k][at.radius_m];
        if (success === null) continue;
      }
      for (const place of [data.episodes[k], relations]) { sums[place] += success; counts[place]++; }
    }
    return sums.map((sum, place) => counts[place] ? sum / counts[place] : null);
  });
  const byRelation = data.relations.map((_, place) => left.filter((is, k) => is && data.episodes[k] === place).length);
  const all = (name) => { const place = data.arms.findIndex((arm) => arm.name === name); return place < 0 ? null : arms[place][relations]; };
  const [arm, baseline] = data.memory.map(all);
  return { rejected, left: byRelation, arms, margin: arm === null || baseline === null ? null : arm - baseline };
}

const sum = (values) => values.reduce((a, b) => a + b, 0);
const share = (value) => value === null ? "–" : value.toFixed(3);
const words = (reason) => reason.replaceAll("_", " ");
const signed = (value, text) => value === 0 ? "" : (value > 0 ? "+" : "−") + text(Math.abs(value));
const before = read(data.start);

function row(cells, kind) {
  const tr = document.createElement("tr");
  cells.forEach((cell, place) => {
    const td = document.createElement(place === 0 ? "th" : kind || "td");
    if (place === 0) td.scope = "row"; else td.className = "number";
    td.append(...[].concat(cell));
    tr.append(td);
  });
  return tr;
}

function number(now, was, text) {
  const change = signed(text === share ? Math.round((now - was) * 1000) / 1000 : now - was, text);
  const small = document.createElement("small");
  small.textContent = change;
  return [now === 0 && text !== share ? "·" : text(now), small];
}

function bar(value, was) {
  const span = document.createElement("span");
  span.className = "bar";
  span.style.setProperty("--now", value === null ? 0 : value);
  span.style.setProperty("--was", was === null ? 0 : was);
  span.setAttribute("aria-hidden", "true");
  return span;
}

function show() {
  const at = Object.fromEntries(names.map((name) => [name, Number($(name).value)]));
  const now = read(at), relations = data.relations.length;
  for (const name of names) {
    const value = data.sliders[name][at[name]], unit = name.endsWith("_px") ? " px" : " m";
    $(name + "_value").textContent = value + unit;
    $(name).setAttribute("aria-valuetext", value + unit + (at[name] === data.start[name] ? ", in force" : ""));
    $(name).closest(".slider").classList.toggle("changed", at[name] !== data.start[name]);
  }
  const total = sum(now.left), was = sum(before.left);
  $("left").textContent = total;
  $("left_of").textContent = `of ${data.episodes.length} released episodes`;
  $("margin").textContent = share(now.margin);
  $("margin_was").textContent = now.margin === before.margin ? "as in force" : `${share(before.margin)} in force`;
  const uncertified = sum(now.rejected[data.reasons.length - 1]);
  $("certified").textContent = sum(now.rejected[0]);
  $("uncertified").textContent = uncertified ? `${uncertified} more trials are admissible and were never certified: the oracle has not run what the setting in force rejects` : "Every admissible trial was run by the oracle";
  const rejections = $("rejections");
  rejections.replaceChildren();
  let stage = null;
  data.reasons.forEach(([reason, of], code) => {
    if (code === 0 || (sum(now.rejected[code]) === 0 && sum(before.rejected[code]) === 0)) return;
    if (of !== stage) {
      const tr = document.createElement("tr"), th = document.createElement("th");
      tr.className = "stage"; th.colSpan = relations + 2; th.textContent = of; tr.append(th); rejections.append(tr); stage = of;
    }
    const counts = now.rejected[code], there = before.rejected[code];
    const tr = row([words(reason), ...counts.map((n, k) => number(n, there[k], String)), number(sum(counts), sum(there), String)]);
    tr.dataset.reason = reason;
    rejections.append(tr);
  });
  const sums = row(["episodes left", ...now.left.map((n, k) => number(n, before.left[k], String)), number(total, was, String)]);
  sums.className = "sum";
  sums.dataset.reason = "left";
  rejections.append(sums);
  for (const kind of ["static", "embodied"]) {
    const body = $(kind);
    if (!body) continue;
    body.replaceChildren();
    let block = null;
    for (const wanted of ["system", "control", "handed"]) data.arms.forEach((arm, place) => {
      if (arm.kind !== kind || arm.block !== wanted) return;
      if (wanted !== block && wanted !== "system") {
        const tr = document.createElement("tr"), th = document.createElement("th");
        tr.className = "stage"; th.colSpan = relations + 3; th.textContent = wanted === "control" ? "controls" : "handed some of the truth"; tr.append(th); body.append(tr);
      }
      block = wanted;
      const rates = now.arms[place], there = before.arms[place];
      const title = document.createElement("span"), small = document.createElement("small");
      title.textContent = arm.title; small.textContent = arm.name;
      const tr = row([[title, small], [bar(rates[relations], there[relations])], number(rates[relations], there[relations], share), ...rates.slice(0, relations).map((rate) => [share(rate)])]);
      tr.dataset.arm = arm.name;
      body.append(tr);
    });
  }
  history.replaceState(null, "", "#" + names.filter((name) => at[name] !== data.start[name]).map((name) => `${name}=${data.sliders[name][at[name]]}`).join("&"));
  document.body.dataset.ready = "yes";
}

function begin() {
  const asked = new URLSearchParams(location.hash.slice(1));
  for (const name of names) {
    const place = data.sliders[name].indexOf(Number(asked.get(name)));
    $(name).value = place < 0 ? data.start[name] : place;
    $(name).addEventListener("input", show);
  }
  $("reset").addEventListener("click", () => { for (const name of names) $(name).value = data.start[name]; show(); });
  addEventListener("hashchange", () => location.reload());
  show();
}
begin();
