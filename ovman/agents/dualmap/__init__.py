"""DualMap, reimplemented: observations of a dense tour, the local (concrete) map, and the answers from it.

Written from the paper's description of the method and its constants.
"""
