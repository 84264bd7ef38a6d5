"""What is to be solved, what follows from it before solving, and what comes out."""
