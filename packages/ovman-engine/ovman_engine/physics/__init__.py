"""Rigid bodies on MuJoCo: touched bodies fall, roll, collide and come to rest; all others are fixed."""
