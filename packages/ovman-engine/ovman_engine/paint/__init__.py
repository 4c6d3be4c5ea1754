"""Materials of objects: tones, finishes, substances by type, textures."""
