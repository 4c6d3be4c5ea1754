"""From pictures to maps: arrays in, maps out, without simulator and benchmark."""
