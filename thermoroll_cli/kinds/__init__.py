"""What is particular to each kind of problem, in one module each (`problem.kinds.Kind`), which imports nothing of its kind
before it is asked for."""
