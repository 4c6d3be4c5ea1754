"""The evaluator: it gives agents what they may know of an episode, runs them, and judges what they do."""
