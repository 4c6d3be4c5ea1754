"""The release as a data set in Parquet, with card, Croissant and Zenodo's metadata: `ovman dataset`."""
