"""From pictures to maps. Arrays in, maps out; stands alone: it knows no simulator and no benchmark."""

from ovman.perception.libraries import keep_to_themselves

keep_to_themselves()
