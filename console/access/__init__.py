"""Access control: logins, roles, the guard in front of every request."""
