"""Learn a locomotion policy: environment, rewards, randomisation, PPO, export."""
