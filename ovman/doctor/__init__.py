"""Check what works on this machine, and name the remedy for what does not: `ovman doctor`."""
