"""What things are made of and how that looks: tones, finishes, materials, textures."""
