"""What other thresholds would make of the records: a page with sliders, and the functions of the workflow that it agrees with."""
