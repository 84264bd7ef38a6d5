"""A wheelset on a track: both wheels on both rails, their contact patches found from profiles and position.

Frames, as in programs for railway vehicles: x along travel, y to the right, z down; the origin lies in the plane on top of the
rails, in the middle of the track. Everything here holds for a right wheel; a left one is mirrored first (`placement.mirrored`).
"""
