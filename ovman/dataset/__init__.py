"""The release as a data set that others load: tables in Parquet, a card, Croissant and Zenodo metadata."""
