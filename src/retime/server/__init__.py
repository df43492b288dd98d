"""The editor's server: messages, the solver, the session, the guard and the app."""
