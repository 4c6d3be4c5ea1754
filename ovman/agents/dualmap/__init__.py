"""DualMap, reimplemented: observations of a dense walk, the local (concrete) and the global (abstract) map, and what they answer.

Written from the paper's description of the method and its constants.
"""
