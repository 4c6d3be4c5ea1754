"""What the sections of config.yaml hold that have more to say than a few numbers; `sections` puts them together."""
