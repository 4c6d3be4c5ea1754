"""Graphs and embeddings of phrases, made of the weights that ultralytics and open_clip load: `ovman export`."""
