"""Write pages about episodes and the runs of agents on them."""
