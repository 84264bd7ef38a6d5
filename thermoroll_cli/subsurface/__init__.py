"""Below the surface: elastic and thermal stresses and temperatures inside both bodies, from what acts on their surfaces."""
