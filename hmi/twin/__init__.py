"""The 3D twin: robot models, their motion, and the scene that browsers see."""
