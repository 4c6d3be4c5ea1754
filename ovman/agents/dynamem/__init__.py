"""DynaMem, reimplemented: a memory of voxels that forgets what a later view sees through, and what it answers.

Written from the paper's abstract and the behaviour and constants of the released code (Liu et al., "DynaMem: Online Dynamic
Spatio-Semantic Memory for Open World Mobile Manipulation", 2024; hello-robot/stretch_ai, Apache-2.0).
"""
