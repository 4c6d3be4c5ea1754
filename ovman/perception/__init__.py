"""From pictures to maps. Arrays in, maps out; stands alone: it knows no simulator and no benchmark."""
