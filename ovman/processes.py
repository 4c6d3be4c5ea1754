"""Processes of this machine, and how the machine is told from others that share its files."""

from __future__ import annotations

import os
import re

HOST = re.sub(r"[^A-Za-z0-9-]", "-", os.uname().nodename)
"""The name of this machine, in letters that a file's name may have and without a full stop."""


def alive(process: int) -> bool:
    """Whether a process of that id runs on this machine."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
