"""REACT, reimplemented: clusters of instances that look alike, matched between two visits by the distance that they travelled.

Written from the behaviour of the released code (Nguyen, Verdoja and Kyrki, "REACT:
Real-time Efficient Attribute Clustering and Transfer for Updatable 3D Scene Graph", 2025; aalto-intelligent-robotics/REACT, MIT).
"""
