"""Friction power loss: kinematics at the contact points, friction, efficiency, maps."""
