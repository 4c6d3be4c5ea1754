"""Controls: agents that read no noun and run no network. What they reach says what a split measures."""
