"""What methods over a lattice share: near-regular synthesis and the best tile."""
