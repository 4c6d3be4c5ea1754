"""From records to rates, intervals and tests."""
