"""Agents: the interface, the reference agent, the oracle and the baselines. They know nothing of the evaluator."""
