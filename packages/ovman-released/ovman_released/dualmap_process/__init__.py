"""The program that runs DualMap, started by `ovman_released.dualmap_runner` with the interpreter of DualMap's environment.

There it is a package of its own, `python -m dualmap_process request.json`, since the packages around it ask for a newer Python
than DualMap's. Its modules import Python's library and NumPy, and by name, while they run, what DualMap's environment has.
"""
