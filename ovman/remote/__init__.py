"""An agent in a process of its own, here or elsewhere: the evaluator's side of the protocol, and a host for arms of ours."""
