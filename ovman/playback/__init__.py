"""Pages about episodes and their runs, and recordings that Rerun shows in three dimensions and in time."""
