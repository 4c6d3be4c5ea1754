"""Training of the small networks of the default configuration on pictures of floor plans that the benchmark does not use.

`make models` repeats it.
"""
