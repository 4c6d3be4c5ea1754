"""MuJoCo: what is touched falls, rolls, strikes and comes to rest; everything else stays fixed."""
