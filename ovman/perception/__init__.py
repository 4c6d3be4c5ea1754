"""From pictures to maps: arrays in, maps out, without simulator and benchmark.

The network libraries read these variables once, at import.
"""

import os

from ovman.shipped import user_cache

# At import ultralytics contacts two hosts and writes settings; at inference it reports usage.
os.environ["YOLO_OFFLINE"] = "true"
# ultralytics would install missing packages with pip into the locked environment.
os.environ["YOLO_AUTOINSTALL"] = "false"
os.environ.setdefault("YOLO_CONFIG_DIR", str(user_cache()))
os.environ.setdefault("YOLO_VERBOSE", "false")
os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")
