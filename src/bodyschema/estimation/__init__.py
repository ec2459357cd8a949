"""One belief about one model: noise, problem, solver, estimate, and what the data tell."""
