"""What is made of many contacts in balance or in time: wheelsets, ball bearings, contacts over time."""
