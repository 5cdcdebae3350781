"""A studio in the browser: a server on this machine, and the page that it serves.

`server` starts it, `app` has its routes, `guard` keeps others out; a tab is a session of
`sessions`, what it makes is a job of `jobs`, from a recipe of `weftex.recipe`.
"""
