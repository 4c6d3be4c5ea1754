"""Episodes and runs as a recording that is looked at in three dimensions and in time (Rerun)."""
