"""The question and the answer: `Problem` with bodies, materials and profiles, `Result` with its states, names and units."""
