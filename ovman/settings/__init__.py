"""What the sections of config.yaml hold that have more to say than a few numbers; ``ovman.sections`` puts them together."""
