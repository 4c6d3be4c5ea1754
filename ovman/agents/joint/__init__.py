"""The joint agent: evidence of a change and of the noun first, objects of both visits from it, one decision last."""
