"""`python -m ovman.cli`: the command `ovman`."""

import sys

from ovman.cli import main

sys.exit(main())
