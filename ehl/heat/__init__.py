"""Heat in the steady smooth line contact: surfaces, film, and what they do to friction."""
