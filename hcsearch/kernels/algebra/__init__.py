"""Small operations that compiled loops share: rows of tables, vectors and matrices as tuples."""
