"""Tools shared by the measurements."""
