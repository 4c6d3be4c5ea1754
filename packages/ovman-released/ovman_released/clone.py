"""A user's clone of a released system: is it the commit that was read, with nothing changed in it?"""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

TIMEOUT_S = 60.0


@dataclass(frozen=True)
class Clone:
    """repository: where it is cloned from; root: the folder that it is said to be in; commit: the pinned one."""

    repository: str
    root: Path
    commit: str

    def lacks(self) -> str | None:
        """What is wrong with the clone and what to do, in one line; None for a clean checkout of the pinned commit.

        Files that Git does not track (weights, caches) and submodules do not count.
        """
        clone = f"run: git clone {self.repository} {self.root} && git -C {self.root} checkout {self.commit}"
        if not self.root.is_dir():
            return f"there is no clone in {self.root}; {clone}"
        try:
            top, head = self._git("rev-parse", "--show-toplevel"), self._git("rev-parse", "HEAD")
            changed = self._git("status", "--porcelain", "--untracked-files=no", "--ignore-submodules").splitlines()
        except FileNotFoundError:
            return "git is not installed, which says whether a clone is the pinned commit; install it"
        except subprocess.TimeoutExpired:
            return f"git does not answer in {self.root}; is the disk there?"
        except subprocess.CalledProcessError as error:
            said = " ".join(error.stderr.split()) or "git failed"
            return f"{self.root} is no clone that git can read ({said}); {clone}"
        if Path(top).resolve() != self.root.resolve():
            return f"{self.root} lies inside another repository and is none itself; {clone}"
        if head != self.commit:
            return f"the clone in {self.root} is at {head[:12]}; run: git -C {self.root} checkout {self.commit}"
        if changed:
            return f"{changed[0][3:]} in the clone {self.root} was changed; run: git -C {self.root} checkout -- ."
        return None

    def _git(self, *arguments: str) -> str:
        command = ["git", "-C", str(self.root), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=True, stdin=subprocess.DEVNULL)
        return done.stdout.rstrip("\n")
