"""`bodyschema track`: its file, its pictures, its folder and what it answers."""
