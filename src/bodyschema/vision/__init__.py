"""How the body would look to its own cameras, and how well that fits what they see."""
