"""Train the small networks of the default configuration, on pictures of floor plans that the benchmark does not use.

`make models` repeats the training. The modules with PyTorch need the extra `networks`.
"""
