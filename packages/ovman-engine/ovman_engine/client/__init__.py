"""AI2-THOR's interface: the wire protocol, and the settings, metadata and images of a client's session."""
