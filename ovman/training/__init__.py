"""How the small networks of the default configuration were made: pictures of the floor plans that the benchmark does not use, and
two trainings. `make models` does it again."""
