"""Tables of the results, from rates to files."""
