"""Parameter sweeps: one case solved for every combination of values of some of its keys.

Points are divided into short stretches of neighbours. A stretch is what one worker solves, each point starting from the
one before it, and the division depends on nothing but the swept values: the same sweep gives the same results in one
process, in many, and on a cluster.
"""
