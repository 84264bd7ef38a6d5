"""Heat that comes back: what earlier turns of a body have left on the track that meets the contact again."""
