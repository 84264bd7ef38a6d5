"""Many solves that answer one question: sweeps and fits, tables of creep forces, profiles that wear."""
